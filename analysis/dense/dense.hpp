// SPDX-License-Identifier: Apache-2.0
/// Declares Eigen's decompositions of dense matrices as instantiated in dense.cpp. It is precompiled for every room of
/// the analysis, so that none of its files instantiates them again, which took half of the time to compile them. A
/// file includes the headers of Eigen that it uses, not this one.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

// GYROTHERM_DENSE is `extern` here, and nothing in dense.cpp.
#ifndef GYROTHERM_DENSE
#define GYROTHERM_DENSE extern
#endif

GYROTHERM_DENSE template class Eigen::LLT<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::LDLT<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::HouseholderQR<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::JacobiSVD<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
GYROTHERM_DENSE template class Eigen::HouseholderSequence<Eigen::MatrixXd, Eigen::VectorXd>;

// Member templates are no part of a class that is instantiated.
GYROTHERM_DENSE template Eigen::LLT<Eigen::MatrixXd>& Eigen::LLT<Eigen::MatrixXd>::compute<Eigen::MatrixXd>(
    const Eigen::EigenBase<Eigen::MatrixXd>&);
GYROTHERM_DENSE template Eigen::Index Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked<Eigen::MatrixXd>(
    Eigen::MatrixXd&);
GYROTHERM_DENSE template Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>&
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>::compute<Eigen::MatrixXd>(const Eigen::EigenBase<Eigen::MatrixXd>&, int);
