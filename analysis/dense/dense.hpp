// SPDX-License-Identifier: Apache-2.0
/// Declares the explicit instantiations of Eigen's dense decompositions that dense.cpp defines. Every part of the
/// analysis precompiles this header, so the decompositions are compiled once; instantiating them in each file took half
/// of the compile time. A file includes the Eigen headers that it uses, not this header.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

// Expands to `extern` here and to nothing in dense.cpp.
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

// Instantiating a class does not instantiate its member templates.
GYROTHERM_DENSE template Eigen::LLT<Eigen::MatrixXd>& Eigen::LLT<Eigen::MatrixXd>::compute<Eigen::MatrixXd>(
    const Eigen::EigenBase<Eigen::MatrixXd>&);
GYROTHERM_DENSE template Eigen::Index Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked<Eigen::MatrixXd>(
    Eigen::MatrixXd&);
GYROTHERM_DENSE template Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>&
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>::compute<Eigen::MatrixXd>(const Eigen::EigenBase<Eigen::MatrixXd>&, int);
