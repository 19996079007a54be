/PROG  PORTS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  DO[1]=ON ;
   2:  RO[2]=OFF ;
   3:  GO[1]=5 ;
   4:  AO[1]=7 ;
   5:  F[3]=(DO[1] AND !RO[2]) ;
   6:  R[1]=GO[1] ;
   7:  R[2]=AI[1] ;
   8:  WAIT DI[1] ;
   9:  IF (DI[1] AND F[3]),DO[2]=(ON) ;
  10:  IF DI[1]=ON AND RI[1]=OFF,CALL ACTION ;
  11:  R[5]=3 ;
  12:  DO[R[5]]=DI[1] ;
/POS
/END
--> load action.ls
